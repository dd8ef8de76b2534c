"""Persson's theory of contact mechanics: functions of the power spectrum C(q), a solid and a load."""
