"""What PyVista imports, by its entry points, when ``grid.splat`` is first asked for."""

import pyvista

from ._accessor import GridAccessor

pyvista.register_dataset_accessor("splat", pyvista.DataSet)(GridAccessor)
