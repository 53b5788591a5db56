"""A storm of interrupts: programs that move a simulated chassis are sent SIGINT again and again, at random
moments, and the robot must stand when they have ended. `python -m tests.storm --trials 1000`; POSIX only.
"""
