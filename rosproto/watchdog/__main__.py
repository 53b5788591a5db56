"""`python -m rosproto.watchdog`, which `Watchdog` starts; it is of no use by hand."""

from rosproto.watchdog.process import main

main()
