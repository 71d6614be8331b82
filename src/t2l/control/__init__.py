"""Controllers: functions of states to torques."""
