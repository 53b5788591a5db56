# Written by `python -m tools.stubs`; change the definitions instead.
"""Messages of tf as classes."""

from collections.abc import Sequence as _Sequence

import msgdefs.geometry_msgs.msg as _geometry_msgs
from rosproto.codec import Message as _Message

class tfMessage(_Message):
    """tf/tfMessage

    geometry_msgs/TransformStamped[] transforms
    """

    transforms: list[_geometry_msgs.TransformStamped]
    def __init__(
        self,
        transforms: _Sequence[_geometry_msgs.TransformStamped] = ...,
    ) -> None: ...
