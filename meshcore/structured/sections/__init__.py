"""Grids round sections: O, C and H topologies and their far fields (survey 2.8.1)."""
