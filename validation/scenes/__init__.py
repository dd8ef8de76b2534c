"""What is asked: tables of a scene, its surface as C(q) and as heights."""
