"""What each action does: predefined actions, maps, triggers, and actions that the user configures."""
