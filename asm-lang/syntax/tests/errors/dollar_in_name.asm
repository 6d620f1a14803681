asm dollar_in_name
import StandardLibrary
signature:
  controlled x: Integer
definitions:
  main rule r_Main = par
    x := X$next  //~ L002
    let ($a = 1) in x := $a$b endlet  //~ L002
    let($a = 1)in$a := 2 endlet
    r_x$y[]  //~ L002
  endpar
