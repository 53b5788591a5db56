"""All frames as a graph for graphviz, as view_frames drew it."""

EDGE = (
    '"%s" -> "%s"[label="Broadcaster: %s\\nAverage rate: %.3f Hz\\nMost recent transform: %.3f %s\\n'
    'Buffer length: %.3f sec\\n"];\n'
)
ROOT = (
    'edge [style=invis];\n subgraph cluster_legend { style=bold; color=black; label ="view_frames Result";\n'
    '"Recorded at time: %.3f"[ shape=plaintext ] ;\n }->"%s";\n'
)


def span(edge):
    """(newest, oldest) stamp, nanoseconds; a static transform has no time of its own."""
    return (0, 0) if edge.static else (edge.newest.stamp, edge.earliest)


def all_frames_as_dot(names, edges, now):
    """The graph's text.

    Args:
        names: All frames, in the order in which they became known.
        edges: The history of each frame that has a parent.
        now: Seconds, for the age of each transform; 0 for none.
    """
    if not names:
        return 'digraph G {\n"no tf data recieved"}'  # spelled as tf2 does
    lines = ["digraph G {\n"]
    roots = []
    for name in names:
        edge = edges.get(name)
        if not edge:
            roots.append(name)
            continue
        newest, oldest = span(edge)
        length = (newest - oldest) / 1e9
        age = "( %.3f sec old)" % (now - newest / 1e9) if now > 0 else ""
        rate = len(edge) / max(length, 0.0001)
        lines.append(EDGE % (edge.newest.parent, name, edge.authority, rate, newest / 1e9, age, length))
    if now > 0:
        lines += [ROOT % (now, name) for name in roots]
    return "".join([*lines, "}"])
