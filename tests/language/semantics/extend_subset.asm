// an element of a subset is an element of the whole
asm extend_subset
import StandardLibrary
signature:
  abstract domain Animal
  domain Cat subsetof Animal
  controlled all: Integer
  controlled cats: Integer
  static rex: Animal
definitions:
  main rule r_Main = seq extend Cat with $c do skip  par all := size(Animal)  cats := size(Cat) endpar endseq
//= step 1: Cat + {cat!1}, all := 2, cats := 1
