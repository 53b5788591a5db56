# Written by `python -m tools.stubs`; change the definitions instead.
"""Messages of roscpp as classes."""

from rosproto.codec import Message as _Message

class Logger(_Message):
    """roscpp/Logger

    string name
    string level
    """

    name: str
    level: str
    def __init__(
        self,
        name: str = ...,
        level: str = ...,
    ) -> None: ...
