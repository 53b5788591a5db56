"""Node: one participant of a ROS 1 graph, and the face of this package.

How the parts hang together (the seam for services, parameters and whatever comes later):

* `_master`: the typed client of the master (`MasterClient`), made with this node's name as caller id.
* `_registrations`: the table of what the master knows about us. A part that is registered gives it an object
  with `kind`, `name`, `register(master)`, `unregister(master)`; the watchdog registers all of it again when the
  master restarted or our address changed.
* `_slave`: the slave API. `_slave.on_parameter_update(key, value, trusted) -> bool` is the parameter cache's
  hook: True when subscribed; `trusted` False means the call did not come from the master's address, so ask
  the master for the value instead of believing it.
* `_tcpros`: the one TCPROS server. It reads the connection header of every incoming connection and gives a
  header with `topic` to the publications, one with `service` to `_tcpros.on_service(sock, fields, peer)`, which
  runs in the connection's own thread and owns the socket until it returns. `_rosrpc_uri` is what services
  register.
* `_closers`: called by `close()`, newest first, before the servers go away; each must be bounded and idempotent.
* `_closing`: set when `close()` begins; every long wait of a part watches it.
* `clock`: the node's time, wall or simulated.
"""
