asm no_overload
import StandardLibrary
signature:
  controlled distance: Prod(Integer, Integer) -> Integer
  controlled x: Integer
definitions:
  main rule r_Main = x := distance("here", 2)  //~ A006
