"""t2l: which controller gains make robot learning work, and where a simulator is wrong."""

import os
import sys

# MuJoCo chooses how to render when it is first imported; EGL needs no display
if sys.platform == "linux" and "DISPLAY" not in os.environ:
    os.environ.setdefault("MUJOCO_GL", "egl")
