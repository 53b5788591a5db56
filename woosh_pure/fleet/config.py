"""`VehicleConfig`, `Broker` and `FleetConfig`: the configuration of `woosh vda5050`, and reading it from a
fleet.toml."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from rosproto.files import read_text
from rosproto.sentence import say
from woosh_pure.geometry import Footprint
from woosh_pure.toml_text import toml_values

VERSIONS = ("2.0.0", "2.1.0")
MAX_VEHICLES = 25
"""Vehicles of one process; `broker_connection.py` says why."""
_ALLOWED = frozenset("ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_.:-")
_SECRETS = ("WOOSH_MQTT_USER", "WOOSH_MQTT_PASSWORD")


def _is_number(value: object) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)


def _is_targets(value: object) -> bool:
    return isinstance(value, Mapping) and all(
        isinstance(name, str) and name and isinstance(target, str) for name, target in value.items()
    )


_KINDS: dict[str, tuple[Callable[[object], bool], str]] = {
    "str": (lambda v: isinstance(v, str), "a text in quotes"),
    "str | None": (lambda v: v is None or isinstance(v, str), "a text in quotes"),
    "bool": (lambda v: isinstance(v, bool), "true or false"),
    "float": (_is_number, "a number"),
    "Mapping[str, str]": (_is_targets, 'a table of texts, such as { beep = "module:function" }'),
    "Sequence[Sequence[float]]": (lambda v: isinstance(v, (list, tuple)), "a list of corners [x, y]"),
}
"""By the type of a field: a check of the value, and the expected value in TOML terms."""


@dataclass(frozen=True, slots=True, kw_only=True)
class VehicleConfig:
    """One vehicle.

    Attributes:
        manufacturer, serial: Names of the vehicle; parts of its topics.
        chassis: Address of the chassis; None uses $ROS_MASTER_URI.
        host: The address of this computer that the robot can reach; None finds it.
        version: Version of the protocol: 2.0.0 or 2.1.0.
        map_id, map_version: The fleet manager's name and version of the chassis's map.
        interface: First level of the topics.
        marks: Whether a node without a position is a mark of the chassis, named by its description or id.
        map_actions: Let the fleet manager download, enable and delete maps (2.1).
        zone_set: zoneSetId of the zones in the chassis's map; "" if there are none.
        charger: Mark of the charger, for startCharging; "" disables it.
        undock: Distance in m that stopCharging drives straight off the charger, negative backwards; 0
            disables it.
        triggers: For waitForTrigger: triggerType -> "python.module:function" or "!program ...", which returns
            when the trigger has come; "" waits for `Vehicle.trigger(type)`.
        tolerance, turn_tolerance: Deviation in m and rad for nodes that allow none.
        visualization: Seconds between two visualization messages; 0 sends none.
        actions: Your own actions: type -> "python.module:function", or "!program argument ...".
        footprint: Corners (x, y) in m in base_link, if the chassis does not provide them.
        series, height, load, acceleration: For the factsheet: m, kg, m/s²; 0 if not known.
    """

    manufacturer: str
    serial: str
    chassis: str | None = None
    host: str | None = None
    version: str = "2.1.0"
    map_id: str = "map"
    map_version: str = "1"
    interface: str = "uagv"
    marks: bool = False
    map_actions: bool = False
    zone_set: str = ""
    charger: str = ""
    undock: float = 0.0
    tolerance: float = 0.2
    turn_tolerance: float = 0.2
    visualization: float = 0.0
    actions: Mapping[str, str] = field(default_factory=dict)
    triggers: Mapping[str, str] = field(default_factory=dict)
    footprint: Sequence[Sequence[float]] = ()
    series: str = "Woosh chassis"
    height: float = 0.0
    load: float = 0.0
    acceleration: float = 0.0

    def __post_init__(self) -> None:
        for each in fields(self):
            fits, expected = _KINDS[str(each.type)]
            if not fits(getattr(self, each.name)):
                text = "{name} {value!r}: expected {expected}"
                raise ValueError(say(text, name=each.name, value=getattr(self, each.name), expected=expected))
        for name in ("manufacturer", "serial", "interface"):
            value = getattr(self, name)
            if not value or not set(value) <= _ALLOWED:
                wrong = "{name} {value!r}: it is part of a topic; use A-Z a-z 0-9 _ . : - only"
                raise ValueError(say(wrong, name=name, value=value))
        if self.version not in VERSIONS:
            raise ValueError(
                say("version {version!r}: expected {names}", version=self.version, names=VERSIONS)
            )
        for name in ("tolerance", "turn_tolerance"):
            if not 0.0 < getattr(self, name) <= 2.0:
                wrong = "{name} {value}: expected more than 0 and at most 2"
                raise ValueError(say(wrong, name=name, value=getattr(self, name)))
        if not (-2.0 <= self.undock <= 2.0):
            raise ValueError(say("undock {undock} m: expected -2 to 2", undock=self.undock))
        if self.map_actions and self.version.startswith("2.0"):
            raise ValueError("map_actions: maps are a part of the protocol since version 2.1.0")
        if self.footprint:
            Footprint.from_points(self.footprint)
        if not (self.visualization == 0.0 or 0.05 <= self.visualization <= 60.0):
            wrong = "visualization {visualization} s: expected 0, or 0.05 to 60"
            raise ValueError(say(wrong, visualization=self.visualization))

    @property
    def prefix(self) -> str:
        """The levels before the topic: "uagv/v2/Woosh/A-17"."""
        return f"{self.interface}/v2/{self.manufacturer}/{self.serial}"


@dataclass(frozen=True, slots=True, repr=False)
class Broker:
    """Address and credentials of the broker.

    Attributes:
        url: mqtt://host:port, or mqtts:// for TLS; without user and password.
        user, password: None if the broker needs none.
        ca_file, cert_file, key_file: For TLS; None uses the system's authorities and no client certificate.
    """

    url: str
    user: str | None = None
    password: str | None = None
    ca_file: str | None = None
    cert_file: str | None = None
    key_file: str | None = None

    def __post_init__(self) -> None:
        expected = f"broker {_without_secrets(self.url)}: expected mqtt://HOST:PORT or mqtts://HOST:PORT"
        try:
            parts = urlsplit(self.url)
            port = parts.port
        except ValueError as error:
            raise ValueError(say("{expected} ({error})", expected=expected, error=error)) from None
        beside = parts.path.strip("/") or parts.query or parts.fragment
        if parts.scheme not in ("mqtt", "mqtts") or not parts.hostname or beside or port == 0:
            raise ValueError(expected)
        if parts.username or parts.password:
            raise ValueError(
                "the broker's address must not hold a user or password: others on this computer see it; "
                "use $WOOSH_MQTT_USER and $WOOSH_MQTT_PASSWORD, or a file"
            )
        if not self.tls and (self.ca_file or self.cert_file or self.key_file):
            raise ValueError("certificates are for TLS: write mqtts://HOST:PORT")

    def __repr__(self) -> str:
        return f"<Broker {self.url}>"

    @property
    def tls(self) -> bool:
        """Whether the connection is encrypted."""
        return urlsplit(self.url).scheme == "mqtts"

    @property
    def host(self) -> str:
        """Host name or address."""
        return urlsplit(self.url).hostname or ""

    @property
    def port(self) -> int:
        """The port; 1883, or 8883 for TLS, if the URL has none."""
        return urlsplit(self.url).port or (8883 if self.tls else 1883)


def _without_secrets(url: str) -> str:
    return url.rpartition("@")[2]


@dataclass(frozen=True, slots=True, kw_only=True)
class FleetConfig:
    """A broker and the vehicles of one process.

    Attributes:
        broker: The broker.
        vehicles: At least one, with different serial numbers.
        folder: Folder of the state files; None uses the user's default folder.
    """

    broker: Broker
    vehicles: tuple[VehicleConfig, ...]
    folder: Path | None = None

    def __post_init__(self) -> None:
        if not self.vehicles:
            raise ValueError("no vehicle is given; a fleet.toml has one [[vehicle]] for each")
        prefixes = [vehicle.prefix for vehicle in self.vehicles]
        twice = {prefix for prefix in prefixes if prefixes.count(prefix) > 1}
        if twice:
            wrong = "several vehicles are called {names}; each needs its own serial"
            raise ValueError(say(wrong, names=", ".join(sorted(twice))))


def secrets(path: Path | None = None) -> tuple[str | None, str | None]:
    """Read user and password of the broker from a file of two lines, or from $WOOSH_MQTT_USER and
    $WOOSH_MQTT_PASSWORD.

    Raises:
        ValueError: Other users may read the file, or it does not have two lines.
    """
    if path is None:
        user, password = (os.environ.get(name) or None for name in _SECRETS)
        return user, password
    if path.is_dir():
        raise ValueError(
            say("{path} is a folder; expected a file of two lines, user and password", path=path)
        )
    if os.name == "posix" and path.stat().st_mode & 0o077:
        raise ValueError(say("{path}: other users can read it; run chmod 600 {path}", path=path))
    lines = read_text(path).splitlines()
    if len(lines) < 2 or not lines[0]:
        raise ValueError(
            say("{path}: expected the user in its first line and the password in its second", path=path)
        )
    return lines[0], lines[1]


def load_config(path: Path) -> FleetConfig:
    """Read a fleet.toml: `[broker]` with url and files, and a `[[vehicle]]` with the fields of
    `VehicleConfig` for each vehicle.

    Raises:
        ValueError: The file is not TOML, or a name or value is invalid; the text says which.
        OSError: The file cannot be read.
    """
    try:
        data = toml_values(read_text(path), "fleet")
    except UnicodeDecodeError:
        raise ValueError(say("{path} is not text in UTF-8; a fleet.toml is", path=path)) from None
    except ValueError as error:
        raise ValueError(say("{path} is not TOML: {error}", path=path, error=error)) from None
    try:
        return _fleet(data, path.parent)
    except (TypeError, ValueError) as error:
        raise ValueError(say("{path}: {error}", path=path, error=error)) from None


def _fleet(data: dict[str, Any], folder: Path) -> FleetConfig:
    unknown = set(data) - {"broker", "vehicle", "folder"}
    if unknown:
        wrong = "{names} is not known; expected [broker], [[vehicle]] and folder"
        raise ValueError(say(wrong, names=", ".join(sorted(unknown))))
    given, vehicles = data.get("broker", {}), data.get("vehicle", [])
    if not isinstance(given, dict):
        raise ValueError("broker: expected a table, [broker], with url")
    if not (isinstance(vehicles, list) and all(isinstance(raw, dict) for raw in vehicles)):
        raise ValueError("vehicle: expected tables, one [[vehicle]] for each")
    texts = {**given, "folder": data.get("folder", "")}
    for name, value in texts.items():
        if not isinstance(value, str):
            raise ValueError(say("{name} {value!r}: expected a text in quotes", name=name, value=value))
    given = dict(given)
    file = given.pop("secrets_file", None)
    user, password = secrets(folder / file if file else None)
    _require_known(given, ("url", "ca_file", "cert_file", "key_file"), "[broker]")
    if "url" not in given:
        raise ValueError("[broker] has no url")
    if len(vehicles) > MAX_VEHICLES:
        raise ValueError(
            say(
                "{count} vehicles are too many for one process, which takes {max_vehicles}: each "
                "needs some 30 open files, and MQTT takes no more than 1024; write several files, and"
                " start `woosh vda5050` once for each",
                count=len(vehicles),
                max_vehicles=MAX_VEHICLES,
            )
        )
    known = [each.name for each in fields(VehicleConfig)]
    for raw in vehicles:
        _require_known(raw, known, "[[vehicle]]")
        missing = [name for name in ("manufacturer", "serial") if name not in raw]
        if missing:
            raise ValueError(say("a [[vehicle]] has no {names}", names=missing))
    kept = data.get("folder")
    return FleetConfig(
        broker=Broker(user=user, password=password, **given),
        vehicles=tuple(VehicleConfig(**raw) for raw in vehicles),
        folder=None if kept is None else folder / kept,
    )


def _require_known(given: Mapping[str, object], known: Iterable[str], where: str) -> None:
    unknown = sorted(set(given) - set(known))
    if unknown:
        hint = " (secrets are in the environment or a secrets_file)" if "password" in unknown else ""
        wrong = "{where}: {names} is not known{hint}; expected {known}"
        raise ValueError(say(wrong, where=where, names=", ".join(unknown), hint=hint, known=", ".join(known)))
