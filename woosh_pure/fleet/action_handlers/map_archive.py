"""Download and unpack a map archive (6.7): a ZIP of a map_server YAML and its picture.

Sizes are limited, and files are unpacked to a temporary folder without their paths.
"""

from __future__ import annotations

import hashlib
import io
from collections.abc import Callable
from pathlib import Path
from urllib.parse import urlsplit

from rosproto.sentence import say
from rosproto.text import printable
from woosh_pure.errors import ChassisError
from woosh_pure.maps.gridmap import GridMap

MOST_DOWNLOAD = 64_000_000
"""Largest download, bytes."""
MOST_UNPACKED = 256_000_000
"""Largest size of the unpacked files, bytes."""
_SILENCE = 20.0  # s without a byte after which a download has failed
_HASHES = {32: "md5", 40: "sha1", 64: "sha256", 128: "sha512"}  # by their hexadecimal digits


def fetch(link: str, cancelled: Callable[[], bool], digest: str = "") -> bytes:
    """Download a file.

    Args:
        link: An http:// or https:// URL; others are refused.
        cancelled: Called between two blocks; True ends the download.
        digest: MD5, SHA-1, SHA-256 or SHA-512 in hexadecimal digits, chosen by the length; "" checks nothing.

    Raises:
        ChassisError: The download failed, is too large, or does not match the digest.
    """
    from urllib.error import URLError  # imported late: not needed to start a vehicle
    from urllib.request import Request, urlopen

    where = printable(link)[:200]
    if urlsplit(link).scheme not in ("http", "https") or not urlsplit(link).hostname:
        raise ChassisError(say("mapDownloadLink {where}: expected http:// or https://", where=where))
    kind = _HASHES.get(len(digest)) if digest else "sha256"
    if kind is None:
        raise ChassisError(
            say(
                "mapHash of {count} characters: expected 32, 40, 64 or 128 hexadecimal digits",
                count=len(digest),
            )
        )
    found = bytearray()
    try:
        with urlopen(Request(link), timeout=_SILENCE) as reply:
            while piece := reply.read(65536):
                found += piece
                if len(found) > MOST_DOWNLOAD:
                    raise ChassisError(
                        say(
                            "{where}: more than {most_download} bytes; send a smaller map",
                            where=where,
                            most_download=MOST_DOWNLOAD,
                        )
                    )
                if cancelled():
                    raise ChassisError("the download was cancelled")
    except (OSError, ValueError, URLError) as error:
        raise ChassisError(say("{where} could not be fetched: {error}", where=where, error=error)) from error
    if digest and hashlib.new(kind, found).hexdigest() != digest.lower():
        raise ChassisError(
            say("{where}: what came is not what mapHash says ({kind})", where=where, kind=kind)
        )
    return bytes(found)


def unpack(data: bytes) -> GridMap:
    """Read the map from an archive.

    Raises:
        ChassisError: The data is not a map archive.
    """
    import tempfile
    import zipfile

    try:
        with zipfile.ZipFile(io.BytesIO(data)) as packed, tempfile.TemporaryDirectory() as folder:
            infos = [info for info in packed.infolist() if not info.is_dir()]
            if sum(info.file_size for info in infos) > MOST_UNPACKED:
                raise ChassisError(
                    say(
                        "the map is larger than {most_unpacked} bytes when unpacked",
                        most_unpacked=MOST_UNPACKED,
                    )
                )
            names = [Path(info.filename.replace("\\", "/")).name for info in infos]
            sheets = [name for name in names if name.lower().endswith((".yaml", ".yml"))]
            if len(sheets) != 1 or len(set(names)) != len(names):
                listed = ", ".join(printable(name) for name in names[:10]) or "nothing"
                raise ChassisError(
                    say(
                        "a map is a ZIP of one YAML of map_server and its picture; in this are {listed}",
                        listed=listed,
                    )
                )
            for info, name in zip(infos, names, strict=True):
                (Path(folder) / name).write_bytes(packed.read(info))
            return GridMap.load(Path(folder) / sheets[0], beside=True)
    except (zipfile.BadZipFile, zipfile.LargeZipFile, NotImplementedError, EOFError, OSError) as error:
        raise ChassisError(say("the file is no ZIP of a map: {error}", error=error)) from error
    except (ValueError, RuntimeError) as error:
        raise ChassisError(say("the map cannot be read: {error}", error=error)) from error
