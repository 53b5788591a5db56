"""All frames as a graph for graphviz, as view_frames drew it."""

EDGE = (
    '"%s" -> "%s"[label="Broadcaster: %s\\nAverage rate: %.3f Hz\\nMost recent transform: %.3f %s\\n'
    'Buffer length: %.3f sec\\n"];\n'
)
ROOT = (
    'edge [style=invis];\n subgraph cluster_legend { style=bold; color=black; label ="view_frames Result";\n'
    '"Recorded at time: %.3f"[ shape=plaintext ] ;\n }->"%s";\n'
)


def all_frames_as_dot(names, caches, authorities, now):
    """The graph's text.

    Args:
        names: All frames, in the order in which they were heard of.
        caches: The cache of each frame that has a parent.
        authorities: Who told of it.
        now: Seconds, for the age of each transform; 0 for none.
    """
    if not names:
        return 'digraph G {\n"no tf data recieved"}'  # its spelling
    lines = ["digraph G {\n"]
    roots = []
    for name in names:
        cache = caches.get(name)
        if cache is None or not cache.poses:
            roots.append(name)
            continue
        newest, oldest, count = cache.span()
        length = (newest - oldest) / 1e9
        age = "( %.3f sec old)" % (now - newest / 1e9) if now > 0 else ""
        authority = authorities.get(name, "no recorded authority")
        rate = count / max(length, 0.0001)
        lines.append(EDGE % (cache.newest()[1], name, authority, rate, newest / 1e9, age, length))
    if now > 0:
        lines += [ROOT % (now, name) for name in roots]
    return "".join([*lines, "}"])
