"""What everything else is made of: meshes, poses, cameras, parameters, scenes, buffers."""
