"""Which physical effects a model lacks: one search over known effects and learned laws.

The loop is linearised once along the recordings (`linear_loop`), every candidate's torque is sent
through it (`responses`), sets of candidates are screened by their error on recordings that were
left out (`screen`), fitted along the motion (`along_motion`) and grown there (`forward`), the best
few are fitted in full simulation (`fit`, `corrected`), one rule decides (`rule`), and the search
repeats from what was adopted (`search`).
"""
