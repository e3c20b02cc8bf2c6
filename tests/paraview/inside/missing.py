"""Loads the plugin where something may be missing and uses it; imports nothing of meshcore."""

from __future__ import annotations

import os

import paraview.simple as pv

pv.LoadPlugin(os.environ["MESHCORE_PLUGIN"], remote=False)
print("the plugin is loaded", flush=True)
model = pv.meshcoreModel(Model="Square", Resolution=3)
model.UpdatePipeline()
print("the model has", model.GetDataInformation().GetNumberOfCells(), "cells", flush=True)
pv.meshcoreTransfiniteInterpolation(South=model).UpdatePipeline()
pv.meshcoreReader(FileName="/nowhere.poly").UpdatePipeline()
