"""`woosh vda5050`: the chassis as a vehicle of a fleet manager, until interrupted."""

from __future__ import annotations

import time
from argparse import ArgumentParser, Namespace
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from rosproto.cli import finite, never_wait_for_stdout, positive, seconds
from rosproto.sentence import say
from woosh_pure.cli.arguments import add_watchdog, corners
from woosh_pure.cli.connection import chosen, names, reaching, simulated, watchdog_of
from woosh_pure.cli.output import Output

if TYPE_CHECKING:
    from woosh_pure.fleet import FleetConfig, VehicleConfig


def add_vda5050(parser: ArgumentParser) -> None:
    add = parser.add_argument
    add("--broker", metavar="URL", help="mqtt://HOST:PORT, or mqtts:// for TLS")
    add("--manufacturer", default="Woosh", help="part of the topics (Woosh)")
    add("--serial", help="serial number of this vehicle, part of the topics")
    add("--version", choices=("2.0.0", "2.1.0"), default="2.1.0", help="version of the protocol (2.1.0)")
    add("--map-id", default="map", help="the fleet manager's name of the chassis's map (map)")
    add("--interface", default="uagv", help="first level of the topics (uagv)")
    add("--marks", action="store_true", help="treat a node without a position as a mark of the chassis")
    add("--charger", default="", metavar="MARK", help="mark of the charger, for startCharging")
    add(
        "--undock",
        type=finite,
        default=0.0,
        metavar="M",
        help="distance that stopCharging drives straight (negative: backwards)",
    )
    add("--maps", action="store_true", help="let the fleet manager download, enable and delete maps")
    add("--zone-set", default="", metavar="ID", help="zoneSetId of the zones in the chassis's map")
    add(
        "--footprint",
        metavar="CORNERS",
        help='outline for the factsheet, if the chassis has none, m: "0.4,0.3 -0.4,0.3 -0.4,-0.3 0.4,-0.3"',
    )
    add(
        "--tolerance",
        type=positive,
        default=0.2,
        metavar="M",
        help="distance within which a node is reached (0.2)",
    )
    add("--visualization", type=positive, metavar="S", help="send a visualization message every S seconds")
    add(
        "--action",
        action="append",
        default=[],
        metavar="NAME=TARGET",
        help="an action of yours: python.module:function, '!program ...' or mission:FILE (repeat for more)",
    )
    add(
        "--trigger",
        action="append",
        default=[],
        metavar="TYPE=TARGET",
        help="what waitForTrigger waits for: a function or program (as --action) that ends at the trigger",
    )
    add(
        "--secrets",
        type=Path,
        metavar="FILE",
        help="file with user and password on two lines, readable only by you (or $WOOSH_MQTT_USER and "
        "$WOOSH_MQTT_PASSWORD)",
    )
    add("--ca", metavar="FILE", help="certificates of the authorities to trust, for mqtts://")
    add("--cert", metavar="FILE", help="client certificate, if the broker asks for one")
    add("--key", metavar="FILE", help="its key")
    add("--config", type=Path, metavar="FILE", help="a fleet.toml: several chassis in one process")
    add("--state", type=Path, metavar="FOLDER", help="where orders are kept for a restart")
    add("--for", dest="seconds", type=seconds, metavar="S", help="end after this many seconds")
    add_watchdog(parser)


def run_vda5050(args: Namespace, out: Output) -> None:
    never_wait_for_stdout()
    from rosproto.transport import Deadline
    from woosh_pure.chassis import Chassis
    from woosh_pure.fleet import Store, Vehicle
    from woosh_pure.fleet.broker_connection import paho
    from woosh_pure.state_file import default_folder

    paho()
    config = _config(args)
    folder = args.state or config.folder or default_folder()
    with ExitStack() as stack:
        watchdog = stack.enter_context(watchdog_of(args))
        for each in config.vehicles:
            vehicle = each
            if args.sim:
                vehicle = replace(each, chassis=simulated(args, out, stack))
            address, host = vehicle.chassis, vehicle.host
            if address is None:
                address, host = chosen(args)
            with reaching():
                chassis = stack.enter_context(
                    Chassis(address, host=host, resolve=names(args), watchdog=watchdog or False)
                )
            store = Store(folder, vehicle.manufacturer, vehicle.serial)
            stack.enter_context(Vehicle(chassis, vehicle, config.broker, store))
            out.line(
                "{vehicle}: {uri} under {broker}; Ctrl-C ends it",
                vehicle=vehicle.prefix,
                uri=chassis.master_uri,
                broker=config.broker.url,
            )
        out.result({"vehicles": [each.prefix for each in config.vehicles], "broker": config.broker.url})
        deadline = Deadline(args.seconds)
        while not deadline.expired:
            time.sleep(min(0.5, deadline.remaining() or 0.5))


def _config(args: Namespace) -> FleetConfig:
    from woosh_pure.fleet.config import Broker, FleetConfig, load_config, secrets

    if args.config is not None:
        if args.broker or args.serial:
            raise ValueError("--config names brokers and vehicles: give it, or --broker and --serial")
        return load_config(args.config)
    if not (args.broker and args.serial):
        raise ValueError("give --broker URL and --serial NUMBER, or --config FILE")
    user, password = secrets(args.secrets)
    broker = Broker(args.broker, user, password, args.ca, args.cert, args.key)
    return FleetConfig(broker=broker, vehicles=(_vehicle(args),), folder=args.state)


def _vehicle(args: Namespace) -> VehicleConfig:
    from woosh_pure.fleet.config import VehicleConfig

    return VehicleConfig(
        manufacturer=args.manufacturer,
        serial=args.serial,
        version=args.version,
        map_id=args.map_id,
        interface=args.interface,
        marks=args.marks,
        charger=args.charger,
        tolerance=args.tolerance,
        visualization=args.visualization or 0.0,
        actions=_targets("--action", args.action),
        triggers=_targets("--trigger", args.trigger),
        map_actions=args.maps,
        zone_set=args.zone_set,
        undock=args.undock,
        footprint=corners(args.footprint) if args.footprint else (),
    )


def _targets(option: str, given: list[str]) -> dict[str, str]:
    found = {}
    for text in given:
        name, equals, target = text.partition("=")
        if not (name and equals and target):
            wrong = "{option} {text}: expected NAME=python.module:function or NAME='!program argument'"
            raise ValueError(say(wrong, option=option, text=text))
        found[name] = target
    return found
