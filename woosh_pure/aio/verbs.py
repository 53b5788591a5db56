"""From a verb of the threaded `Chassis` to the awaited one: same name, same arguments, same types.

The signature is taken over by type checkers (a ParamSpec) and at run time (`help`, `inspect.signature`), so
that an argument that a verb gets is there, too, and nothing is written twice.
"""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Coroutine
from typing import TYPE_CHECKING, Any, Concatenate, ParamSpec, Protocol, TypeVar

from woosh_pure.aio.calls import Calls
from woosh_pure.aio.drive import VelocityBlock
from woosh_pure.aio.goals import Goal, GoalHandle

if TYPE_CHECKING:
    from woosh_pure.motion import goal as threaded
    from woosh_pure.velocity.drive import Drive

__all__ = ["block", "goal", "like", "stopping", "verb"]

P = ParamSpec("P")
R = TypeVar("R")
H = TypeVar("H", bound=GoalHandle[Any])


class Face(Protocol):
    """What a verb finds in the awaited `Chassis`."""

    @property
    def chassis(self) -> object: ...

    @property
    def _calls(self) -> Calls: ...


def like(method: Callable[..., Any], made: R, returns: str = "") -> R:
    """Name, documentation and signature of a threaded verb for the awaited one; its own return, if given."""
    functools.update_wrapper(made, method)  # type: ignore[arg-type]  # a function, of whatever type
    signature = inspect.signature(method)
    if returns:
        signature = signature.replace(return_annotation=returns)
    vars(made)["__signature__"] = signature
    vars(made).pop("__wrapped__")
    return made


def verb(
    method: Callable[Concatenate[Any, P], R],
) -> Callable[Concatenate[Face, P], Coroutine[Any, Any, R]]:
    """A verb that is awaited. Cancelled, what has not been sent is not sent any more."""

    async def call(self: Face, /, *args: P.args, **kwargs: P.kwargs) -> R:
        return await self._calls.call(lambda: method(self.chassis, *args, **kwargs))

    return like(method, call)


def stopping(
    method: Callable[Concatenate[Any, P], R],
) -> Callable[Concatenate[Face, P], Coroutine[Any, Any, R]]:
    """A verb that ends something: it completes, and a cancelled task waits for that."""

    async def call(self: Face, /, *args: P.args, **kwargs: P.kwargs) -> R:
        return await self._calls.finish(lambda: method(self.chassis, *args, **kwargs))

    return like(method, call)


def goal(
    method: Callable[Concatenate[Any, P], threaded.GoalHandle[Any]], handle: type[H]
) -> Callable[Concatenate[Face, P], Goal[H]]:
    """A verb that begins a goal: see `Goal`."""

    def begin(self: Face, /, *args: P.args, **kwargs: P.kwargs) -> Goal[H]:
        def send() -> threaded.GoalHandle[Any]:
            return method(self.chassis, *args, **kwargs)

        return Goal(method.__name__, self._calls, send, handle)

    return like(method, begin, f"Goal[{handle.__name__}]")


def block(method: Callable[Concatenate[Any, P], Drive]) -> Callable[Concatenate[Face, P], VelocityBlock]:
    """The verb that opens a velocity block."""

    def begin(self: Face, /, *args: P.args, **kwargs: P.kwargs) -> VelocityBlock:
        return VelocityBlock(self._calls, lambda: method(self.chassis, *args, **kwargs))

    return like(method, begin, "VelocityBlock")
