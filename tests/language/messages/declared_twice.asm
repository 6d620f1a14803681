asm declared_twice
import StandardLibrary
signature:
  controlled x: Integer
  controlled x: Integer  //~ A009
definitions:
  main rule r_Main = skip
