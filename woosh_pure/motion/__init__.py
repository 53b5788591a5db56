"""Motion by goals: tasks to marks, navigation to poses, precise steps, and their handles."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosproto.late import late_names

if TYPE_CHECKING:
    from woosh_pure.motion.action_goal import (
        ActionHandle,
        NavigationHandle,
        NavigationProgress,
        StepHandle,
        StepProgress,
    )
    from woosh_pure.motion.goal import GoalHandle
    from woosh_pure.motion.steps import Step
    from woosh_pure.motion.task import TaskHandle

__all__ = [
    "ActionHandle",
    "GoalHandle",
    "NavigationHandle",
    "NavigationProgress",
    "Step",
    "StepHandle",
    "StepProgress",
    "TaskHandle",
]

__getattr__ = late_names(
    __name__,
    {
        "ActionHandle": "action_goal",
        "GoalHandle": "goal",
        "NavigationHandle": "action_goal",
        "NavigationProgress": "action_goal",
        "Step": "steps",
        "StepHandle": "action_goal",
        "StepProgress": "action_goal",
        "TaskHandle": "task",
    },
)
