exec(open("/tmp/m42/common.py").read())
import collections
c=collections.Counter(); ex=collections.defaultdict(list)
import random
for mod in modules():
    src=(PK/mod).read_text(); tree=ast.parse(src); sp=spans(PK/mod)
    st={}
    def walk(n,kls):
        for ch in ast.iter_child_nodes(n):
            if isinstance(ch,ast.stmt):
                k=type(ch).__name__
                if isinstance(ch,ast.Assign) or isinstance(ch,ast.AnnAssign):
                    t=ch.targets[0] if isinstance(ch,ast.Assign) else ch.target
                    nm=getattr(t,'id','?'); v=ch.value
                    k=("class " if kls else "")+("CONST" if nm.isupper() else "name")+" "+(type(v).__name__ if v is not None else "")
                for l in range(ch.lineno,ch.end_lineno+1): st[l]=k
            walk(ch,kls or isinstance(ch,ast.ClassDef))
    walk(tree,False)
    for x in {y.line:y for y in mutants_of(PK/mod,mod)}.values():
        if reaching(mod,x.line) is None:
            k=st.get(x.line,"?")+" / "+x.kind; c[k]+=1; ex[k].append(x.name)
for k,n in c.most_common(40): print(n,k, random.sample(ex[k],min(2,n)))
