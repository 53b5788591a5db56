"""`python -m rosproto.watchdog`, started by `Watchdog`; not for use by hand."""

from rosproto.watchdog.process import main

main()
