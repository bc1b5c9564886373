from yade import export, pack
O.periodic=True
O.materials.append(FrictMat(young=1e7,poisson=0.3,frictionAngle=0.4,density=2650))
sp=pack.SpherePack()
sp.makeCloud((0,0,0),(2.8e-3,2.8e-3,2.8e-3),rMean=0.4e-3,rRelFuzz=.2,num=24,periodic=True,seed=3)
sp.toSimulation()
sp.save('cloud.txt')
O.engines=[ForceResetter(),InsertionSortCollider([Bo1_Sphere_Aabb()],allowBiggerThanPeriod=True),InteractionLoop([Ig2_Sphere_Sphere_ScGeom()],[Ip2_FrictMat_FrictMat_FrictPhys()],[Law2_ScGeom_FrictPhys_CundallStrack()]),
NewtonIntegrator(damping=.3)]
O.dt=.3*PWaveTimeStep()
O.cell.velGrad=Matrix3(-2,0,0,0,-2,0,0,0,-2)
while O.cell.volume>1.10e-8: 
  O.run(200,True)

O.cell.velGrad=Matrix3.Zero
O.engines[-1].damping=.7
O.run(20000,True)
O.cell.velGrad=Matrix3(0,3,0,0,0,0,-1,0,0)
O.run(3000,True)
O.cell.velGrad=Matrix3.Zero
O.run(5000,True)
print('ITER',O.iter,'STRESS',getStress(), 'n',len([i for i in O.interactions if i.isReal]), O.cell.hSize)
export.textExt('ext.txt',format='x_y_z_r',comment='hello')
export.text('text.txt')
ve=export.VTKExporter('yade')
ve.exportSpheres(what={'vel':'b.state.vel','m':'b.state.mass'})
ve.exportInteractions(what={'fn':'i.phys.normalForce.norm()','fnv':'i.phys.normalForce','fs':'i.phys.shearForce'})
ve.exportContactPoints(what={'normalForce':'i.phys.normalForce','shearForce':'i.phys.shearForce','id1':'i.id1','id2':'i.id2'})
try:
  ve.exportPeriodicCell()
except Exception as e: print(e)
