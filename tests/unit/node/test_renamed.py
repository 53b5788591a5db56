"""Names of rosproto.node that have changed: the old ones work, with a warning."""

from __future__ import annotations

import pytest

import rosproto.node


@pytest.mark.parametrize(
    ("old", "new"), [("NoRevisions", "OwnDefinitionsOnly"), ("Unfit", "UnconvertibleMessage")]
)
def test_an_old_name_is_the_new_one_with_a_warning(old: str, new: str) -> None:
    with pytest.warns(DeprecationWarning, match=new):
        assert getattr(rosproto.node, old) is getattr(rosproto.node, new)


def test_a_name_that_never_was_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="no attribute 'Nothing'"):
        _ = rosproto.node.Nothing
