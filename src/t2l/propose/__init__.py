"""What no known effect explains, as a curve over one variable.

- `laws`, `tendons`, `limits`: which laws there are, and where; `bases`: the functions that a curve
  is a sum of
- `band`, `shared_constants`: how sure a curve is
- `expression`, `formula`, `formula_fit`, `cross_validation`: a short formula for a curve
- `proposal`, `artefacts`, `wording`: what is written
"""
