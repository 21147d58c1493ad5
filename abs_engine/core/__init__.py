"""The vocabulary of all rooms: meshes, poses, cameras, parameters, scenes, buffers, errors."""
