"""Writes normal.in and incomplete_gamma.in beside itself: 60-digit values (mpmath), rounded to f64. Points where
mpmath does not converge are left out, and said so."""
import mpmath as mp, random
mp.mp.dps=60
f=open('normal.in','w')
f.write('[\n')
random.seed(5)
xs=[-38.4,-37.5,-30.3,-26.1,-20.7,-15.2,-10.9,-8.1,-6.6,-5.0,-4.2,-3.3,-2.4,-1.7,-1.1,-.6,-.26,-.25,-.24,-.1,-1e-3,-1e-9,0.,1e-9,1e-3,.2,.3,.7,1.3,2.2,4.4,7.7,9.,39.,41.]
xs+=[random.uniform(-37,6) for _ in range(30)]
for x in xs:
    p=mp.erfc(-mp.mpf(x)/mp.sqrt(2))/2
    if x<-37.6: continue
    f.write(f'({x!r}, {float(p)!r}),\n')
f.write(']\n'); f.close()
rows=[]
def PQ(a,x):
    a=mp.mpf(a);x=mp.mpf(x)
    q=mp.gammainc(a,x,mp.inf,regularized=True)
    p=mp.gammainc(a,0,x,regularized=True)
    return p,q
mp.mp.dps=60
As=[1e-12,3e-4,1e-3,.01,.1,.3,.5,.75,.999,1.,1.0001,1.5,2,3.7,4,7.5,9.99,10.,11.9,12.,12.5,15,20,24.9,25.,27.,33.3,70,150,1000.,12345.6]
for a in As:
    lam=[1e-30,1e-6,1e-3,.05,.3,.32,.5,.7,.9,.97,.999,1.,1.001,1.03,1.1,1.4,1.9,2.3,2.4,4,10,100]
    for l in lam:
        x=float(a*l)
        rows.append((float(a),x))
    if a<=2:
        for x in [1e-40,1e-10,1e-3,.1,.5,.9,.999,1.,1.001,1.2,2,5,10,40,200,650]:
            rows.append((float(a),float(x)))
for a in [1e6,2e5+.5]:
    for z in [-30,-10,-5,-2,-1,-.1,0,.1,1,2,5,10,30]:
        rows.append((a,a+z*a**.5))
f=open('incomplete_gamma.in','w')
f.write('[\n')
for a,x in rows:
    try:
        p,q=PQ(a,x)
    except Exception as e:
        print('fail',a,x,e); continue
    if abs(p+q-1)>1e-40: print('bad',a,x,mp.nstr(p,10),mp.nstr(q,10)); continue
    fp,fq=float(p),float(q)
    f.write(f'({a!r}, {x!r}, {fp!r}, {fq!r}),\n')
f.write(']\n'); f.close()
print(len(rows))
