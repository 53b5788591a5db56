"""rosbridge protocol v2. `protocol` is the wire, without sockets; `session` does what a client asks for."""
