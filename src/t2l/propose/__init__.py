"""What no known effect explains, learned from the recordings as a curve over one variable.

- `laws`: which laws there are, and where; `bases`: the functions that a curve is a sum of
- `dictionary`: what the simulation answers to each of them; `ridge`: the curve that fits best
- `search`: laws taken one after the other, refitted through the simulation, judged on other data
- `band`: how sure a curve is; `decision`: when a known effect may be named instead
- `formula`, `effect_file`: a short formula for a curve, and a file of the user's with it
- `artefacts`: what is written, with `wording`
"""
