// one mistake: a name contains no `$`
asm dollar_in_name
import StandardLibrary
signature:
  controlled x: Integer
definitions:
  main rule r_Main = par
    x := X$next  //~ L002
    let ($a = 1) in x := $a$b endlet  //~ L002
  endpar
