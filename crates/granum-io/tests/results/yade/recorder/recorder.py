# 24 spheres in a skewed periodic cell, without and with friction, at rest, as YADE's VTKRecorder records them.
# The compression is so fast that two pairs of spheres pass into one another without a contact: the files are what counts here.
# Written with YADE 2023.02a of Debian 12: MU=0 yade -n -x recorder.py > stress.txt; MU=0.4 yade -n -x recorder.py >> stress.txt
# The recorder intr is used with multiblock=True: without it this version writes the contacts of a periodic cell and then crashes,
# while it writes an index of pieces of any size (hundreds of megabytes).
import os
from yade import pack
mu=float(os.environ['MU'])
O.periodic=True
O.materials.append(FrictMat(young=1e7,poisson=0.3,frictionAngle=mu,density=2650))
sp=pack.SpherePack()
sp.makeCloud((0,0,0),(2.8e-3,2.8e-3,2.8e-3),rMean=0.4e-3,rRelFuzz=.4,num=24,periodic=True,seed=3)
sp.toSimulation()
O.engines=[ForceResetter(),InsertionSortCollider([Bo1_Sphere_Aabb()],allowBiggerThanPeriod=True),InteractionLoop([Ig2_Sphere_Sphere_ScGeom()],[Ip2_FrictMat_FrictMat_FrictPhys()],[Law2_ScGeom_FrictPhys_CundallStrack()]),
NewtonIntegrator(damping=.3)]
O.dt=.3*PWaveTimeStep()
O.cell.velGrad=Matrix3(-2,0,0,0,-2,0,0,0,-2)
while O.cell.volume>1.05e-8: O.run(200,True)
O.cell.velGrad=Matrix3.Zero
O.engines[-1].damping=.7
O.run(20000,True)
O.cell.velGrad=Matrix3(0,3,0,0,0,0,-1,0,0)
O.run(3000,True)
O.cell.velGrad=Matrix3.Zero
O.run(5000,True)
s=getStress()
print('STRESS',mu,*[repr(float(s[i][j])) for i in range(3) for j in range(3)],len([i for i in O.interactions if i.isReal]))
b=O.bodies[5]
print('BODY5',mu,*[repr(float(x)) for x in list(O.cell.wrap(b.state.pos))+[b.shape.radius,b.state.mass]+list(b.state.vel)+list(b.state.angVel)])
if mu==0:
    VTKRecorder(fileName='smooth-',recorders=['spheres','velocity','id','mass','force','pericell','intr'],skipNondynamic=False,multiblock=True)()
else:
    VTKRecorder(fileName='rough-',recorders=['spheres','id','velocity'],skipNondynamic=False,ascii=True)()
    VTKRecorder(fileName='rough-',recorders=['pericell'],ascii=True)()
    VTKRecorder(fileName='rough-',recorders=['intr'],multiblock=True)()
