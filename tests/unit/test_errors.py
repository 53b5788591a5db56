"""Errors can be pickled and copied without loss."""

from __future__ import annotations

import copy
import pickle

import pytest

from rosproto.errors import BagError, MasterError, RosError, RosTimeout, ServiceError, TooLarge
from rosproto.tf import UnknownFrame


@pytest.mark.parametrize(
    "error",
    [
        RosError("plain"),
        BagError("cut off", path="a.bag", offset=7),
        RosTimeout("too late", what="/scan", seconds=2.0),
        MasterError("lookupNode", -1, "unknown node", uri="http://10.0.0.7:11311"),
        ServiceError("/set", "no"),
        TooLarge("message_bytes", 5, 4),
        UnknownFrame("no frame laser", frame="laser"),
    ],
    ids=lambda error: type(error).__name__,
)
def test_an_error_survives_pickle_and_copy(error: RosError) -> None:
    """Whatever its constructor takes: a pool of processes waits for ever for one that does not."""
    for again in (pickle.loads(pickle.dumps(error)), copy.copy(error)):
        assert type(again) is type(error)
        assert (str(again), again.args, vars(again)) == (str(error), error.args, vars(error))
