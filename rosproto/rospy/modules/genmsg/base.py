"""genmsg.base: its constants and errors."""

SEP = "/"
MSG_DIR, SRV_DIR = "msg", "srv"
EXT_MSG, EXT_SRV = ".msg", ".srv"


class InvalidMsgSpec(Exception):
    """A definition is wrong."""


class MsgGenerationException(Exception):
    """A file is not a definition."""
