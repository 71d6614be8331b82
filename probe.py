import sys, tempfile, pathlib, numpy as np, time
from tests.diagnose.made import *
from t2l.effects.learned import *
from t2l.identify.model import Model, read_model, write_model
t=pathlib.Path(tempfile.mkdtemp())
r=pendulum(t)
rec=recording(r, swing(), duration_s=2.0)
base=predict(rec)
q=np.linspace(-1.5,1.5,60)
m=Model(r, learned=(Curve(Law("torque","hinge","position","hinge"),tuple(q),tuple(0.05*np.sin(10*q))),))
write_model(m,t/"m.yaml"); m2=read_model(t/"m.yaml")
a=predict(rec,model=m2); b=predict(rec,{"cogging":{"amplitude":{"hinge":.05},"phase":{"hinge":0.},"periods":{"hinge":10.}}})
print("cogging", np.std(a-base), np.std(a-b))
v=np.linspace(-20,20,20)
m=Model(r, learned=(Curve(Law("torque","hinge","velocity","hinge"),tuple(v),tuple(-0.05*v)),))
a=predict(rec,model=m); b=predict(rec,{"viscous_friction":{"damping":{"hinge":.05}}})
print("viscous", np.std(a-base), np.std(a-b))
m=Model(r, learned=(Curve(Law("friction","hinge","constant","hinge"),(0.,1.),(.05,.05)),))
a=predict(rec,model=m); b=predict(rec,{"coulomb_friction":{"torque":{"hinge":.05}}})
print("coulomb", np.std(a-base), np.std(a-b))
for rr in (1e-3,1e-2):
    m=Model(r, learned=(Curve(Law("hysteresis","hinge","distance","hinge"),(0.,rr,1.),(0,-.05,-.05)),))
    a=predict(rec,model=m)
    print("hyst", rr, np.std(a-base), np.std(a-b))
