"""The files of a build: STEP, meshes, GLB, bill of materials, mass properties, pictures, manifest.

A writer takes what it writes, such as the `assembly` and the `meshes` by part number in mm, and the `path` of its file.
"""
