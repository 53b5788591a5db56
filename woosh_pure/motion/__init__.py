"""Motion by goals: tasks to marks, navigation to poses, precise steps, and their handles."""

from __future__ import annotations

from woosh_pure.motion.action_goal import ActionHandle, NavigationHandle, StepHandle
from woosh_pure.motion.motion import GoalHandle
from woosh_pure.motion.progress import Progress
from woosh_pure.motion.steps import Step
from woosh_pure.motion.task import TaskHandle

__all__ = [
    "ActionHandle",
    "GoalHandle",
    "NavigationHandle",
    "Progress",
    "Step",
    "StepHandle",
    "TaskHandle",
]
