"""An oracle for closecall's logs that shares no code with the tool: brute force over triangles and instants.

It knows the scene file (poses, bodies), the distance of two bodies at an instant (distance), and what the log
promises (check). It imports nothing of closecall and no fcl.
"""
