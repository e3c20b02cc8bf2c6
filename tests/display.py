"""A virtual display for programs with windows."""

# A server that loses its last client starts anew, and refuses whoever comes meanwhile: as ParaView, which looks what
# it may draw before it opens a window.
DISPLAY = ("xvfb-run", "-a", "-s", "-screen 0 1280x1024x24 -noreset")
