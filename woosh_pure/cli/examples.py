"""Commands to copy: shown by `--help`, printed in docs/commands.md, and parsed by a test."""

from __future__ import annotations

__all__ = ["EXAMPLES"]

EXAMPLES: dict[str, tuple[str, ...]] = {
    "sim": ("woosh sim --speed 4", "woosh sim --port 0 --at 10=estop --at 20=release"),
    "connect": ("woosh connect 169.254.128.2", "woosh connect --show"),
    "doctor": ("woosh --chassis 169.254.128.2 doctor",),
    "selftest": ("woosh selftest",),
    "ready": ("woosh ready --wait 120",),
    "faults": ("woosh faults", "woosh faults --find localization --chinese"),
    "scan": ("woosh scan --png scan.png",),
    "camera": ("woosh camera", "woosh camera --depth --png depth.png"),
    "goto": ("woosh goto A1", "woosh goto --pose 1 -1.5 90 --timeout 60", "woosh --sim goto B1"),
    "task": ("woosh task carry P1 --load",),
    "task pause": ("woosh task pause",),
    "charge": ("woosh charge C1",),
    "move": ("woosh move 0.5", "woosh move -0.3 --speed 0.1"),
    "rotate": ("woosh rotate 90", "woosh rotate -45"),
    "map save": ("woosh map save hall",),
    "plan": ("woosh plan 3 1 0 --png way.png",),
    "localization pose": ("woosh localization pose 1 0.5 90",),
    "footprint": ("woosh footprint --rectangle 0.8 0.6",),
    "mode": ("woosh mode wait-then-avoid --waiting-timeout 10 --max-speed 0.5",),
    "marks add": ("woosh marks add 仓库 --note 'east door'",),
    "led": ("woosh led idle", "woosh led --color ff8000 --strip both"),
    "say": ("woosh say 你好",),
    "record": ("woosh record -O drive.bag --duration 10m",),
    "web": ("woosh --sim web", "woosh web --bind 0.0.0.0 --token Kd83-hsa2-Pq"),
    "shell": ("woosh --sim shell",),
    "completion": ('eval "$(woosh completion bash)"',),
}
"""By command and verb."""
