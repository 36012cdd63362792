"""napari: its layers as data, its viewer as a scene, and the plugin. Nothing here is imported before it is used."""
