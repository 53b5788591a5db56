"""Pages are written without the space that nobody sees."""

from __future__ import annotations

from tools.page_size import on_post_page


def test_space_stays_where_it_is_shown() -> None:
    """A line end is as much as many, and as any indentation; code keeps all of its own."""
    code = "<pre><code>def f():\n\n    return 1\n</code></pre>"
    page = f"<p>\n    one\n\n\n  two  three\n</p>\n{code}\n  <script>\n  // a\n\n  b\n</script>\n"
    assert on_post_page(page) == f"<p>\none\ntwo  three\n</p>\n{code}\n<script>\n  // a\n\n  b\n</script>\n"
