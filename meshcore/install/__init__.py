"""Put meshcore into ParaView and Blender, take it out again, and tell what works: `meshcore install|uninstall|doctor`.

MeshLab has no plugins in Python: its filters come with meshcore itself, for any Python that has pymeshlab.
"""

from .blender import install_blender, uninstall_blender
from .doctor import Finding, doctor
from .paraview import install_paraview, uninstall_paraview

__all__ = ["Finding", "doctor", "install_blender", "install_paraview", "uninstall_blender", "uninstall_paraview"]
