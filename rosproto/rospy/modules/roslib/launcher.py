"""load_manifest."""


def load_manifest(package_name, bootstrap_version="0.7"):
    """Nothing is to be done: what a package needs is importable anyway."""
