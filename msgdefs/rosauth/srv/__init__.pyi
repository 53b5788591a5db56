# Written by `python -m tools.stubs`; change the definitions instead.
"""Services of rosauth as classes."""

from typing import TypeAlias as _TypeAlias

from rosproto.codec import Message as _Message
from rosproto.codec import ServiceType as _ServiceType
from rosproto.time import Time as _Time

class AuthenticationRequest(_Message):
    """rosauth/AuthenticationRequest

    string mac
    string client
    string dest
    string rand
    time t
    string level
    time end
    """

    mac: str
    client: str
    dest: str
    rand: str
    t: _Time
    level: str
    end: _Time
    def __init__(
        self,
        mac: str = ...,
        client: str = ...,
        dest: str = ...,
        rand: str = ...,
        t: _Time = ...,
        level: str = ...,
        end: _Time = ...,
    ) -> None: ...

class AuthenticationResponse(_Message):
    """rosauth/AuthenticationResponse

    bool authenticated
    """

    authenticated: bool
    def __init__(
        self,
        authenticated: bool = ...,
    ) -> None: ...

class Authentication(_ServiceType):
    """rosauth/Authentication
    """

    Request: _TypeAlias = AuthenticationRequest
    Response: _TypeAlias = AuthenticationResponse
