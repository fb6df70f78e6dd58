import sys
exec(open("/tmp/m42/common.py").read())
for mod in sys.argv[1:]:
    r=[r for r in pickle.load(open("/tmp/m42/gaps.pkl","rb")) if r[0]==mod][0]
    src=(PK/mod).read_text().splitlines()
    print("=====",mod,len(r[3]),[f"{f} {cost(f):.1f}" for f in own(mod)])
    spans_=sorted(r[3]); 
    groups=[]
    for l in spans_:
        if groups and l-groups[-1][-1]<=4: groups[-1].append(l)
        else: groups.append([l])
    print([(g[0],g[-1]) for g in groups])
