import sys, tempfile, pathlib, numpy as np, time, dataclasses
from tests.diagnose.made import *
from t2l.identify.prediction import Predictor
from t2l.propose.search import search
from t2l.propose.split import split
t=pathlib.Path(tempfile.mkdtemp()); r=pendulum(t)
import t2l.propose.search as S
def timed(n):
    f=getattr(S,n)
    def g(*a,**k):
        t0=time.process_time(); r=f(*a,**k); print(f"   [{n} {time.process_time()-t0:.1f}s cpu]", [len(a[0])] if isinstance(a[0],list) else "", flush=True); return r
    setattr(S,n,g)
for n in ("responses","refit","begin_at_the_best","_left","ranges","scales"): timed(n)
cases={"cogging":{"cogging":{"amplitude":{"hinge":.05},"phase":{"hinge":0.},"periods":{"hinge":10.}}},
"viscous":{"viscous_friction":{"damping":{"hinge":.05}}},
"quadratic":{"quadratic_friction":{"coefficient":{"hinge":.02}}},
"coulomb":{"coulomb_friction":{"torque":{"hinge":.05}}},
"offset":{"torque_offset":{"torque":{"hinge":.05}}},
"noise":{}}
for name in sys.argv[1:] or cases:
    recs=swings(r,cases[name],duration_s=3.0)
    p=Predictor(r,recs,threads=1); f,c=split(p)
    t0=time.time()
    s=S.search(Model(r),p,f,c)
    print(name, f"{time.time()-t0:.1f}s base {1e3*s.baseline_rad:.3g} now {1e3*s.rmse_rad:.3g} floor {1e3*s.noise_floor_rad:.3g}", [(e.law.kind,e.law.follows,f"{pen:.1g}") for e,pen in s.state.laws], flush=True)
    for ce in s.ceilings[:7]: print("    ", ce.law.kind, ce.law.follows, f"{1e3*ce.rmse_rad:.3g}", ce.simulated)
