asm extends_static
import StandardLibrary
signature:
  abstract domain Robot
definitions:
  main rule r_Main = extend Robot with $r do skip  //~ W027
