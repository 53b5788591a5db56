"""A summary of a bag, as `rosbag info` prints it: the same text and the same YAML, line by line.

Only the index is read, which is fast for bags of any size.

Source: rosbag/bag.py, Bag.__str__ and Bag._get_yaml_info.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any

from rosproto.bag.reader import BagReader
from rosproto.text import human_bytes, printable

Facts = dict[str, Any]


def facts(bag: BagReader, *, freq: bool = False, step: Callable[[], None] | None = None) -> Facts:
    """Values for both forms; `freq` adds the median rate of each topic, which needs the index records.

    `step` is called after each chunk, and with `freq` after each chunk of each topic.
    """
    found: Facts = {"path": bag.path or "", "version": bag.version, "size": bag.size, "indexed": bag.indexed}
    if bag.start_time is not None and bag.end_time is not None:
        start, end = bag.start_time.to_sec(), bag.end_time.to_sec()
        found |= {"duration": end - start, "start": start, "end": end, "messages": bag.message_count}
        kinds = bag.compression(step=step)
        found["compression"] = {
            kind: {"chunks": c.chunks, "stored": c.stored_bytes, "plain": c.plain_bytes}
            for kind, c in sorted(kinds.items(), key=lambda item: (item[1].chunks, item[0]), reverse=True)
        }
    types: dict[str, str] = {}
    for connection in bag.connections.values():
        types.setdefault(printable(connection.type), printable(connection.md5sum))
    found["types"] = [{"type": kind, "md5": types[kind]} for kind in sorted(types)]
    found["topics"] = []
    for topic in bag.topics:
        found["topics"].append(_topic_facts(bag, topic, freq, step))
    return found


def _topic_facts(bag: BagReader, topic: str, freq: bool, step: Callable[[], None] | None) -> Facts:
    known = bag.topics[topic]
    found: Facts = {
        "topic": printable(topic),
        "type": printable(known.connections[0].type),
        "messages": known.message_count,
        "connections": len(known.connections),
    }
    rate = bag.frequency(topic, step=step) if freq else None
    return found if rate is None else found | {"frequency": rate}


# -- text --------------------------------------------------------------------------------------------------


def text(found: Facts, curves: Mapping[str, str] = MappingProxyType({})) -> str:
    """The table of rosbag info; `curves`, by topic, are appended to their lines."""
    rows = [("path", found["path"])] if found["path"] else []
    rows.append(("version", found["version"]))
    if "start" in found:
        rows += _span_rows(found)
    else:
        rows.append(("size", human_bytes(found["size"])))
    width = max((len(t["type"]) for t in found["types"]), default=0)
    lines = [f"{t['type']:<{width}} [{t['md5']}]" for t in found["types"]]
    rows += [("" if i else "types", line) for i, line in enumerate(lines)]
    rows += [
        ("" if i else "topics", line) for i, line in enumerate(_topic_lines(found["topics"], width, curves))
    ]
    first = max(len(field) for field, _ in rows) + 1
    return "\n".join(f"{field + ':' if field else '':<{first}} {value}" for field, value in rows).rstrip()


def _span_rows(found: Facts) -> list[tuple[str, str]]:
    kinds: dict[str, dict[str, int]] = found["compression"]
    rows = [
        ("duration", _duration(found["duration"])),
        ("start", f"{_local_time(found['start'])} ({found['start']:.2f})"),
        ("end", f"{_local_time(found['end'])} ({found['end']:.2f})"),
        ("size", human_bytes(found["size"])),
        ("messages", str(found["messages"])),
    ]
    chunks = sum(kind["chunks"] for kind in kinds.values())
    words = [
        f"{name} [{kind['chunks']}/{chunks} chunks"
        + ("]" if name == "none" else f"; {100.0 * kind['stored'] / (kind['plain'] or 1):.2f}%]")
        for name, kind in kinds.items()
    ]
    rows.append(("compression", ", ".join(words) or "none"))
    if set(kinds) - {"none"}:
        rows += _compression_rows(kinds, found["duration"])
    return rows


def _compression_rows(kinds: dict[str, dict[str, int]], duration: float) -> list[tuple[str, str]]:
    plain, stored = (sum(kind[key] for kind in kinds.values()) for key in ("plain", "stored"))
    sizes = [human_bytes(plain), human_bytes(stored)]
    wide = max(map(len, sizes))
    if not duration > 0:
        return [("uncompressed", sizes[0].rjust(wide)), ("compressed", sizes[1].rjust(wide))]
    rates = [human_bytes(plain / duration), human_bytes(stored / duration)]
    far = max(map(len, rates))
    lines = [f"{size:>{wide}} @ {rate:>{far}}/s" for size, rate in zip(sizes, rates, strict=True)]
    return [("uncompressed", lines[0]), ("compressed", f"{lines[1]} ({100.0 * stored / (plain or 1):.2f}%)")]


def _topic_lines(topics: list[Facts], types: int, curves: Mapping[str, str]) -> list[str]:
    """Lines of the topics; `types` is the width of the names of types."""
    if not topics:
        return []
    names = max(len(t["topic"]) for t in topics)
    counts = max(len(str(t["messages"])) for t in topics)
    rates = max(len(_hertz(t["frequency"])) if "frequency" in t else 0 for t in topics)
    lines = []
    for t in topics:
        line = f"{t['topic']:<{names}}   {t['messages']:>{counts}} {'msgs' if t['messages'] > 1 else 'msg '}"
        line += f" @ {_hertz(t['frequency']):>{rates}}" if "frequency" in t else f"   {'':>{rates}}"
        line += f" : {t['type']:<{types}}"
        if t["connections"] > 1:
            line += f" ({t['connections']} connections)"
        lines.append(line)
    wide = max(map(len, lines))
    return [
        f"{line:<{wide}}  {curves[t['topic']]}" if t["topic"] in curves else line
        for line, t in zip(lines, topics, strict=True)
    ]


def _duration(seconds: float) -> str:
    minutes, hours = int(seconds / 60), int(seconds / 3600)
    if hours:
        return f"{hours}hr {minutes % 60}:{int(seconds % 60):02d}s ({int(seconds)}s)"
    return f"{minutes}:{int(seconds % 60):02d}s ({int(seconds)}s)" if minutes else f"{seconds:.1f}s"


def _local_time(seconds: float) -> str:
    fraction = f"{seconds - int(seconds):.2f}"[1:]
    moment = time.localtime(seconds)
    # Not strftime's %b: rosbag's month names are English in all locales.
    month = "Jan Feb Mar Apr May Jun Jul Aug Sep Oct Nov Dec".split()[moment.tm_mon - 1]
    return f"{month} {time.strftime('%d %Y %H:%M:%S', moment)}{fraction}"


def _hertz(rate: float) -> str:
    for suffix in ("Hz", "kHz", "MHz", "GHz"):
        if rate < 1000.0:
            return f"{rate:.1f} {suffix}"
        rate /= 1000.0
    return "-"


# -- YAML --------------------------------------------------------------------------------------------------


def yaml(found: Facts) -> str:
    """The YAML of rosbag info -y."""
    rows, blocks = _yaml_parts(found)
    lines = [f"{name}: {value}" for name, value in rows.items()]
    for name, entries in blocks.items():
        if entries:
            lines += [f"{name}:", *_yaml_entries(entries)]
    return "\n".join(lines) + "\n"


def yaml_value(found: Facts, key: str) -> str:
    """One value of the YAML.

    Raises:
        KeyError: There is no such key; its argument lists the existing ones.
    """
    rows, blocks = _yaml_parts(found)
    if key in rows:
        return rows[key]
    if key in blocks:
        return "\n".join(_yaml_entries(blocks[key]))
    raise KeyError(", ".join([*rows, *blocks]))


def _yaml_parts(found: Facts) -> tuple[dict[str, str], dict[str, list[list[tuple[str, str]]]]]:
    rows: list[tuple[str, str]] = [("path", found["path"])] if found["path"] else []
    rows.append(("version", found["version"]))
    if "start" not in found:
        rows += [("size", str(found["size"])), ("indexed", "False")]
    else:
        rows += _yaml_span(found)
    blocks = {
        "types": [[("type", t["type"]), ("md5", t["md5"])] for t in found["types"]],
        "topics": [_yaml_topic(t) for t in found["topics"]],
    }
    return dict(rows), blocks


def _yaml_span(found: Facts) -> list[tuple[str, str]]:
    kinds: dict[str, dict[str, int]] = found["compression"]
    rows = [(name, f"{found[name]:.6f}") for name in ("duration", "start", "end")]
    rows += [("size", str(found["size"])), ("messages", str(found["messages"])), ("indexed", "True")]
    rows.append(("compression", next(iter(kinds), "none")))
    if set(kinds) - {"none"}:
        rows.append(("uncompressed", str(sum(kind["plain"] for kind in kinds.values()))))
        rows.append(("compressed", str(sum(kind["stored"] for kind in kinds.values()))))
    return rows


def _yaml_topic(topic: Facts) -> list[tuple[str, str]]:
    rows = [("topic", topic["topic"]), ("type", topic["type"]), ("messages", str(topic["messages"]))]
    if topic["connections"] > 1:
        rows.append(("connections", str(topic["connections"])))
    if "frequency" in topic:
        rows.append(("frequency", f"{topic['frequency']:.4f}"))
    return rows


def _yaml_entries(entries: list[list[tuple[str, str]]]) -> list[str]:
    return [
        f"    {'-' if i == 0 else ' '} {name}: {value}"
        for entry in entries
        for i, (name, value) in enumerate(entry)
    ]
