asm library_missing
// one library, one finding
signature:
  controlled x: Integer
definitions:
  main rule r_Main = if isDef(x) and x > 1 then x := x - 1 endif  //~ A036
