"""t2l: which controller gains make robot learning work, and where a simulator is wrong."""

import ctypes
import os
import sys


def _render_without_display() -> None:
    """Let MuJoCo render through EGL where there is no display, but there is EGL.

    MuJoCo chooses when it is first imported, and fails to import where EGL is asked for in vain.
    """
    if sys.platform != "linux" or {"DISPLAY", "MUJOCO_GL"} & set(os.environ):
        return
    try:
        ctypes.CDLL("libEGL.so.1")
    except OSError:
        return
    os.environ["MUJOCO_GL"] = "egl"


_render_without_display()
