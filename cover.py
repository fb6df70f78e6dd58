exec(open("/tmp/m42/common.py").read())
rows=pickle.load(open("/tmp/m42/gaps.pkl","rb"))
add={};left=0
for mod,n,imp,none,notown,mine in rows:
    todo=set(notown)
    if not todo: continue
    budget=60-sum(cost(f) for f in mine)
    names=[]
    while todo:
        gain=defaultdict(set)
        for l in todo:
            for f in reaching(mod,l): gain[f].add(l)
        best=max(gain,key=lambda f:len(gain[f])/(1.0+cost(f)))
        if len(gain[best])<2 and cost(best)>3 or cost(best)>budget:
            left+=len(todo); break
        names.append((best,round(cost(best),1),len(gain[best]))); budget-=cost(best); todo-=gain[best]
    if names: add[mod]=names
print(len(add),sum(len(v) for v in add.values()),sum(x[2] for v in add.values() for x in v),"left",left)
pickle.dump(add,open("/tmp/m42/add.pkl","wb"))
for m,v in sorted(add.items()): print(m,v)
