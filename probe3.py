import sys, tempfile, pathlib, numpy as np, time
from tests.diagnose.made import *
from t2l.identify.prediction import Predictor
from t2l.identify.scales import scales
from t2l.propose.search import *
from t2l.propose.split import split
t=pathlib.Path(tempfile.mkdtemp()); r=pendulum(t)
recs=swings(r,{"viscous_friction":{"damping":{"hinge":.05}}},duration_s=3.0)
p=Predictor(r,recs,threads=1); f,c=split(p)
m=Model(r); layout,u=m.vector(p.joints)
(q,),(dq,)=p.predict([Request(layout,u[None])],velocity=True)
left=p.samples.q-q[0]
ends=ranges(p,q[0],dq[0]); tq=scales(p).torque
print(len(ends))
for law in laws(p,left,ends):
    e=effect_of(law,ends[law],.3*tq[0])
    t0=time.time(); a=responses(p,layout,u,[e])[0]; t1=time.time()
    ft=fit(a,left,f,c,penalty(e),e.law.kind!=TORQUE)
    print(law.kind,law.follows,a.shape,f"{t1-t0:.2f}s fit {time.time()-t1:.2f}", f"{1e3*np.sqrt(ft.chosen):.3g} pen {ft.penalty:.2g}",flush=True)
t0=time.time(); a=responses(p,layout,u,[effect_of(law,ends[law],.3*tq[0]) for law in laws(p,left,ends)]); print("all",time.time()-t0)
