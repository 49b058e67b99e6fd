import './studio.css'; console.log('x');
