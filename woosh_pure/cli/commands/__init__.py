"""One file for each command of `woosh`; `woosh_pure.cli.registry` names them."""

__all__: list[str] = []
