"""The configuration of vehicles, and where secrets may be."""

from __future__ import annotations

import math
import os
import sys
from dataclasses import fields
from pathlib import Path

import pytest

from woosh_pure import Chassis
from woosh_pure.fleet.action_handlers.predefined_actions import supported_actions
from woosh_pure.fleet.config import Broker, FleetConfig, VehicleConfig, load_config, secrets
from woosh_pure.fleet.vehicle import Vehicle

TOML = """
folder = "kept"
[broker]
url = "mqtts://broker:8883"
ca_file = "/etc/ca.pem"
[[vehicle]]
manufacturer = "Woosh"
serial = "A-17"
chassis = "169.254.128.2"
[[vehicle]]
manufacturer = "Woosh"
serial = "A-18"
version = "2.0.0"
"""


def test_a_file_names_a_broker_and_its_vehicles(tmp_path: Path) -> None:
    """With the names of the classes; folders are beside the file."""
    path = tmp_path / "fleet.toml"
    path.write_text(TOML)
    fleet = load_config(path)
    assert [vehicle.prefix for vehicle in fleet.vehicles] == ["uagv/v2/Woosh/A-17", "uagv/v2/Woosh/A-18"]
    assert (fleet.broker.host, fleet.broker.port, fleet.broker.tls) == ("broker", 8883, True)
    assert fleet.folder == tmp_path / "kept"


@pytest.mark.parametrize(
    ("text", "match"),
    [
        ("[broker", "fleet.toml"),
        ("[broker]\n", "no url"),
        ('[broker]\nurl = "mqtt://b"\n', "no vehicle"),
        ('[broker]\nurl = "mqtt://b"\npassword = "x"\n', "secrets_file"),
        (TOML + "speed = 3\n", "speed is not known"),
        (TOML.replace("A-18", "A-17"), "serial of its own|own serial"),
        (TOML.replace("2.0.0", "1.1"), "expected 2.0.0, 2.1.0"),
    ],
)
def test_what_makes_no_sense_is_named(tmp_path: Path, text: str, match: str) -> None:
    """With the file's name."""
    path = tmp_path / "fleet.toml"
    path.write_text(text)
    with pytest.raises(ValueError, match=match) as caught:
        load_config(path)
    assert "fleet.toml" in str(caught.value)


@pytest.mark.parametrize("name", ["", "A/17", "A+", "A#", "$SYS", "a b"])
def test_parts_of_a_topic_are_checked(name: str) -> None:
    """Nothing in a serial number leads to somebody else's topics."""
    with pytest.raises(ValueError, match="part of a topic"):
        VehicleConfig(manufacturer="Woosh", serial=name)


@pytest.mark.promise("an address that contains one is refused")
@pytest.mark.parametrize(
    ("url", "match"),
    [
        ("broker", "expected mqtt"),
        ("http://broker", "expected mqtt"),
        ("mqtt://me:secret@broker", "must not hold"),
        ("mqtt://", "expected mqtt"),
    ],
)
def test_an_address_of_a_broker_holds_no_secret(url: str, match: str) -> None:
    """Command lines are seen by everybody on a computer; nor does the error repeat it."""
    with pytest.raises(ValueError, match=match) as caught:
        Broker(url)
    assert "secret" not in str(caught.value)


def test_a_password_is_not_in_the_repr() -> None:
    """Nor in a log by way of it."""
    broker = Broker("mqtt://b", "me", "hush")
    fleet = FleetConfig(broker=broker, vehicles=(VehicleConfig(manufacturer="W", serial="1"),))
    assert "hush" not in repr(fleet)


def test_certificates_want_tls() -> None:
    """They would be of no effect else."""
    with pytest.raises(ValueError, match="mqtts"):
        Broker("mqtt://b", ca_file="ca.pem")


@pytest.mark.promise("an address that contains one is refused")
@pytest.mark.skipif(os.name != "posix", reason="permissions of POSIX")
def test_secrets_are_in_a_file_of_ones_own(tmp_path: Path) -> None:
    """One that others may read is refused."""
    path = tmp_path / "secrets"
    path.write_text("me\nhush\n")
    path.chmod(0o644)
    with pytest.raises(ValueError, match="chmod 600"):
        secrets(path)
    path.chmod(0o600)
    assert secrets(path) == ("me", "hush")
    path.write_text("me\n")
    with pytest.raises(ValueError, match="second"):
        secrets(path)


def test_secrets_are_in_the_environment(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where there is no file."""
    monkeypatch.delenv("WOOSH_MQTT_USER", raising=False)
    monkeypatch.delenv("WOOSH_MQTT_PASSWORD", raising=False)
    assert secrets() == (None, None)
    monkeypatch.setenv("WOOSH_MQTT_USER", "me")
    monkeypatch.setenv("WOOSH_MQTT_PASSWORD", "hush")
    assert secrets() == ("me", "hush")


def test_without_the_library_the_error_names_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    """And what to type."""
    from woosh_pure.fleet.broker_connection import paho

    for name in [name for name in sys.modules if name.partition(".")[0] == "paho"]:
        monkeypatch.setitem(sys.modules, name, None)
    monkeypatch.setitem(sys.modules, "paho.mqtt.client", None)
    with pytest.raises(ImportError, match=r"\.\[fleet\]"):
        paho()


WRONG = {
    '[broker]\nurl = "mqtt://h"\n'
    + 26 * '[[vehicle]]\nmanufacturer = "W"\nserial = "1"\n': r"26 vehicles are too many for one",
    'broker = "mqtt://h"': r"broker: expected a table",
    "[broker]\nurl = 3": r"url 3: expected a text",
    '[broker]\nurl = "mqtt://h:x"': r"expected mqtt://HOST:PORT",
    '[broker]\nurl = "mqtt://h:0"': r"expected mqtt://HOST:PORT",
    '[broker]\nurl = "mqtt://h/x"': r"expected mqtt://HOST:PORT",
    'vehicle = 3\n[broker]\nurl = "mqtt://h"': r"vehicle: expected tables",
    'folder = 3\n[broker]\nurl = "mqtt://h"': r"folder 3: expected a text",
    '[broker]\nurl = "mqtt://h"\n[[vehicle]]\nserial = "1"': r"\[\[vehicle\]\] has no manufacturer",
    "a =": r"not TOML",
}
"""What somebody may write, and what is said: with the file's name before it."""


@pytest.mark.parametrize("text", WRONG)
def test_a_file_that_makes_no_sense_is_answered_with_a_sentence(tmp_path: Path, text: str) -> None:
    """And not with a word of Python."""
    path = tmp_path / "fleet.toml"
    vehicle = "" if "vehicle" in text else '\n[[vehicle]]\nmanufacturer = "W"\nserial = "1"\n'
    path.write_text(text + vehicle)
    with pytest.raises(ValueError, match=WRONG[text]) as caught:
        load_config(path)
    assert str(path) in str(caught.value)


def test_a_file_that_is_no_text_is_said_to_be_none(tmp_path: Path) -> None:
    """A picture, for example."""
    path = tmp_path / "fleet.toml"
    path.write_bytes(b"\xff\xfe")
    with pytest.raises(ValueError, match="UTF-8"):
        load_config(path)


@pytest.mark.parametrize("field", [each.name for each in fields(VehicleConfig)])
def test_a_value_of_any_type_at_any_field_is_taken_or_refused_by_name(field: str) -> None:
    """The error begins with the field; nothing fails later, in the middle of an order."""
    for value in (3, True, "x", [3], {"a": 3}, math.nan, None):
        said = ""
        try:
            supported_actions(VehicleConfig(**{"manufacturer": "W", "serial": "1", field: value}))
        except ValueError as error:
            said = str(error)
        assert not said or said.startswith((field, "a footprint", "footprint")), (value, said)


def test_certificates_that_are_none_are_said(tmp_path: Path) -> None:
    """Before anything is connected."""
    pytest.importorskip("paho.mqtt.client", reason="paho-mqtt is not installed")
    (tmp_path / "ca.pem").write_text("junk")
    for name, kind, match in (("ca.pem", ValueError, "ca.pem cannot be used"), ("no.pem", OSError, "no.pem")):
        broker = Broker("mqtts://h", ca_file=str(tmp_path / name))
        with pytest.raises(kind, match=match):
            Vehicle(Chassis("127.0.0.1:1"), VehicleConfig(manufacturer="W", serial="1"), broker)
