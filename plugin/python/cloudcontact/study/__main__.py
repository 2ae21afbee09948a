"""python -m cloudcontact.study: the command cloudcontact-study."""

from .command import main

raise SystemExit(main())
